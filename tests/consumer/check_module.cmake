# Installs a build of pvol into a folder of its own and runs a program in Python there, alone and with
# the shared library. cmake -D BUILD=... -D WORK=... -D PYTHON=... -D NM=... -P check_module.cmake
file(REMOVE_RECURSE ${WORK})
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix
  OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
file(GLOB_RECURSE package ${WORK}/prefix/__init__.py)
file(GLOB_RECURSE module ${WORK}/prefix/_pvol.*.so)
file(GLOB_RECURSE library ${WORK}/prefix/libpvol.so)

# In a program that has a library of its own, functions that both show would be that one's in both.
execute_process(COMMAND ${NM} -D --defined-only ${module} OUTPUT_VARIABLE shown COMMAND_ERROR_IS_FATAL ANY)
if(shown MATCHES " (_Z[A-Z]*4pvol[^\n]*|pvol_[^\n]*)")
  message(FATAL_ERROR "the module shows ${CMAKE_MATCH_1}")
endif()

cmake_path(GET package PARENT_PATH package)
cmake_path(GET package PARENT_PATH packages)
foreach(libraries "" "${library}")
  message(STATUS "libraries of the program: ${libraries}")
  execute_process(COMMAND ${CMAKE_COMMAND} -E env PYTHONPATH=${packages}
      ${PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/module.py ${WORK}/prefix ${BUILD} ${libraries}
    WORKING_DIRECTORY ${WORK} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
