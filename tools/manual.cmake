# Writes a tool's man page and its completion for bash: cmake -D TOOL=... -D PAGE=... -D SCRIPT=...
# -P manual.cmake
foreach(file ${PAGE} ${SCRIPT})
  cmake_path(GET file PARENT_PATH folder)
  file(MAKE_DIRECTORY ${folder})
endforeach()
execute_process(COMMAND ${TOOL} --man OUTPUT_FILE ${PAGE} COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${TOOL} --completion bash OUTPUT_FILE ${SCRIPT} COMMAND_ERROR_IS_FATAL ANY)
