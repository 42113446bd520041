# Makes the object HIDDEN of OBJECT, in which all that it defines is hidden; see self_contained.cmake.
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# Of the objects that name a symbol, the linker takes the visibility that shows least.
run(${NM} --defined-only --extern-only --format=posix ${OBJECT} OUTPUT_FILE ${HIDDEN}.s)
file(STRINGS ${HIDDEN}.s symbols)
list(TRANSFORM symbols REPLACE "^([^ ]+) .*" ".hidden \\1")
list(JOIN symbols "\n" symbols)
file(WRITE ${HIDDEN}.s "${symbols}\n.section .note.GNU-stack,\"\",%progbits\n")
run(${COMPILER} -c ${HIDDEN}.s -o ${HIDDEN}.names)
run(${LINKER} -r -o ${HIDDEN} ${OBJECT} ${HIDDEN}.names)
file(REMOVE ${HIDDEN}.s ${HIDDEN}.names)
