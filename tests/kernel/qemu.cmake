# On real drivers: QEMU boots Debian's kernel with two emulated CAN controllers; daemon, drive simulator and command line
# run in it. Not under sanitizers: their memory does not fit that machine.
find_package(Python3 REQUIRED COMPONENTS Interpreter)
if(NOT CANSYNC_SANITIZE)
  add_test(NAME kernel.qemu COMMAND Python3::Interpreter -B ${CMAKE_CURRENT_LIST_DIR}/run_qemu.py)
  set_tests_properties(kernel.qemu PROPERTIES LABELS kernel SKIP_RETURN_CODE 77 TIMEOUT 630
    ENVIRONMENT "CANSYNC=$<TARGET_FILE:cansync>;CANSYNCD=$<TARGET_FILE:cansyncd>;CANSYNC_SIM=$<TARGET_FILE:cansync-sim>")
endif()
