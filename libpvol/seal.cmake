# Sealing: many objects become one, whose inline functions and instantiated templates belong to it alone.
#
# A compiler leaves a copy of each inline function in every object that calls it, and the linker keeps one
# of them for the whole program. A client that is compiled with -march=native, -ffast-math or -O0 could so
# replace the code that the library runs by its own. In a sealed object these symbols are local; what is
# left to link against are the functions that are defined once. It takes GNU binutils.

# RESULT becomes true where objects can be sealed. Sanitizers need all symbols as they are.
function(pvol_can_seal RESULT)
  set(can FALSE)
  if(CMAKE_SYSTEM_NAME STREQUAL Linux AND CMAKE_OBJCOPY AND CMAKE_NM AND CMAKE_LINKER
      AND NOT PVOL_SANITIZE AND NOT PVOL_THREAD_SANITIZE AND NOT PVOL_FUZZ)
    execute_process(COMMAND ${CMAKE_LINKER} --help OUTPUT_VARIABLE help ERROR_QUIET)
    if(help MATCHES "force-group-allocation")
      set(can TRUE)
    endif()
  endif()
  set(${RESULT} ${can} PARENT_SCOPE)
endfunction()

# RESULT becomes the objects to link: NAME.o made of all of them, or where that cannot be, they
# themselves.
function(pvol_seal RESULT NAME)
  set(objects ${ARGN})
  if(NOT PVOL_SEALS)
    set(${RESULT} ${objects} PARENT_SCOPE)
    return()
  endif()
  set(sealed ${CMAKE_CURRENT_BINARY_DIR}/sealed/${NAME}.o)
  set(list ${CMAKE_CURRENT_BINARY_DIR}/sealed/${NAME}.objects)
  file(GENERATE OUTPUT ${list} CONTENT "$<JOIN:${objects},\n>\n")
  add_custom_command(OUTPUT ${sealed}
    COMMAND ${CMAKE_COMMAND} -D LINKER=${CMAKE_LINKER} -D NM=${CMAKE_NM} -D OBJCOPY=${CMAKE_OBJCOPY}
      -D OBJECTS=${list} -D SEALED=${sealed} -P ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/seal_objects.cmake
    DEPENDS ${objects} ${list} ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/seal_objects.cmake
    COMMENT "Sealing ${NAME}.o" VERBATIM)
  set_source_files_properties(${sealed} PROPERTIES EXTERNAL_OBJECT TRUE GENERATED TRUE)
  set(${RESULT} ${sealed} PARENT_SCOPE)
endfunction()
