# libcansync.so.1: the static libraries' code behind a list of what programs may use, with what is needed to build
# against it. Components: `library` (what programs need to run) and `development`.
find_package(CycloneDDS REQUIRED)
include(CMakePackageConfigHelpers)

add_library(cansync_shared SHARED libcansync.map)
target_link_libraries(cansync_shared PUBLIC CycloneDDS::ddsc PRIVATE cansync_sanitizers $<LINK_LIBRARY:WHOLE_ARCHIVE,cansync_client>)
target_link_options(cansync_shared PRIVATE LINKER:--version-script=${CMAKE_CURRENT_SOURCE_DIR}/libcansync.map)
# A sanitizer's runtime comes with the program.
if(NOT CANSYNC_SANITIZE)
  target_link_options(cansync_shared PRIVATE LINKER:--no-undefined)
endif()
set_target_properties(cansync_shared PROPERTIES OUTPUT_NAME cansync EXPORT_NAME cansync LINKER_LANGUAGE CXX
  VERSION 1.${PROJECT_VERSION} SOVERSION 1 LINK_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/libcansync.map)

# The generated headers that <cansync/topics.h> includes lie beside it when they are installed.
target_include_directories(cansync_shared INTERFACE
  $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include> $<BUILD_INTERFACE:${CMAKE_BINARY_DIR}/idl>
  $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
target_compile_features(cansync_shared INTERFACE cxx_std_20)
add_library(cansync::cansync ALIAS cansync_shared)

install(TARGETS cansync_shared EXPORT cansyncTargets
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library NAMELINK_COMPONENT development)
install(DIRECTORY include/cansync DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development FILES_MATCHING PATTERN *.h)
install(FILES ${CMAKE_BINARY_DIR}/idl/cansync.h ${CMAKE_BINARY_DIR}/idl/gateway.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/cansync COMPONENT development)
install(FILES ${CMAKE_SOURCE_DIR}/idl/cansync.idl ${CMAKE_SOURCE_DIR}/idl/cansync_slave.idl ${CMAKE_SOURCE_DIR}/idl/gateway.idl ${CMAKE_SOURCE_DIR}/idl/overview.idl ${CMAKE_SOURCE_DIR}/idl/layer2.idl ${CMAKE_SOURCE_DIR}/idl/j1939.idl DESTINATION ${CMAKE_INSTALL_DATADIR}/cansync/idl COMPONENT development)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/cansync)
configure_package_config_file(cansyncConfig.cmake.in cansyncConfig.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(cansyncConfigVersion.cmake COMPATIBILITY SameMajorVersion)
install(EXPORT cansyncTargets NAMESPACE cansync:: DESTINATION ${package_folder} COMPONENT development)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/cansyncConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/cansyncConfigVersion.cmake
  DESTINATION ${package_folder} COMPONENT development)
# Relative, so that the package may lie anywhere.
file(RELATIVE_PATH CANSYNC_PREFIX_FROM_PC /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
string(REGEX REPLACE "/$" "" CANSYNC_PREFIX_FROM_PC ${CANSYNC_PREFIX_FROM_PC})
configure_file(cansync.pc.in cansync.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/cansync.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
