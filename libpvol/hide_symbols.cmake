# Makes the object SELF_CONTAINED of those that the file OBJECTS lists; see self_contained.cmake.
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

run(${LINKER} -r --force-group-allocation -o ${SELF_CONTAINED}.open @${OBJECTS})
run(${NM} --defined-only --format=posix ${SELF_CONTAINED}.open OUTPUT_FILE ${SELF_CONTAINED}.symbols)
file(STRINGS ${SELF_CONTAINED}.symbols shared REGEX " [WVu] ")
list(TRANSFORM shared REPLACE " .*" "")
# A template of the random numbers that clients call and cannot instantiate (math/philox.h).
list(FILTER shared EXCLUDE REGEX "PhiloxOf")
list(JOIN shared "\n" shared)
file(WRITE ${SELF_CONTAINED}.symbols "${shared}\n")
run(${OBJCOPY} --localize-symbols=${SELF_CONTAINED}.symbols ${SELF_CONTAINED}.open ${SELF_CONTAINED})
file(REMOVE ${SELF_CONTAINED}.open ${SELF_CONTAINED}.symbols)
