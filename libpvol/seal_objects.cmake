# Makes the object SEALED of those that the file OBJECTS lists; see seal.cmake.
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

run(${LINKER} -r --force-group-allocation -o ${SEALED}.open @${OBJECTS})
run(${NM} --defined-only --format=posix ${SEALED}.open OUTPUT_FILE ${SEALED}.symbols)
file(STRINGS ${SEALED}.symbols shared REGEX " [WVu] ")
list(TRANSFORM shared REPLACE " .*" "")
# A template of the random numbers that clients call and cannot instantiate (math/philox.h).
list(FILTER shared EXCLUDE REGEX "PhiloxOf")
list(JOIN shared "\n" shared)
file(WRITE ${SEALED}.symbols "${shared}\n")
run(${OBJCOPY} --localize-symbols=${SEALED}.symbols ${SEALED}.open ${SEALED})
file(REMOVE ${SEALED}.open ${SEALED}.symbols)
