# cmake -D IDLC=... -D MODEL=cansync -D SOURCE=(folder of the IDL) -D OUT=... -P final_types.cmake
# Runs idlc once more on a data model with final in place of appendable structs and enumerations, and leaves of it
# OUT/final/MODEL_final.c, the descriptors, and OUT/MODEL_final.h, their declarations.
set(folder ${OUT}/final/${MODEL})
file(MAKE_DIRECTORY ${folder})
foreach(model gateway ${MODEL})
  file(READ ${SOURCE}/${model}.idl text)
  string(REPLACE "@appendable" "@final" text "${text}")
  file(WRITE ${folder}/${model}.idl "${text}")
endforeach()
execute_process(COMMAND ${IDLC} -o${folder} ${folder}/${MODEL}.idl COMMAND_ERROR_IS_FATAL ANY)

file(READ ${folder}/${MODEL}.c text)
string(REGEX REPLACE "_desc([^a-z])" "_final_desc\\1" text "${text}")
file(WRITE ${OUT}/final/${MODEL}_final.c "${text}")

file(READ ${folder}/${MODEL}.h text)
string(REGEX MATCHALL "extern const dds_topic_descriptor_t [A-Za-z0-9_]+_desc" declarations "${text}")
set(text "#pragma once\n#include <dds/dds.h>\n#ifdef __cplusplus\nextern \"C\" {\n#endif\n")
foreach(declaration ${declarations})
  string(REGEX REPLACE "_desc$" "_final_desc" declaration ${declaration})
  string(APPEND text "${declaration};\n")
endforeach()
string(APPEND text "#ifdef __cplusplus\n}\n#endif\n")
file(WRITE ${OUT}/${MODEL}_final.h "${text}")
