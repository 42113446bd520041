# Self-contained objects: many objects become one, whose inline functions and instantiated templates belong
# to it alone. Hidden objects: nothing of theirs is seen outside the program or plug-in that they become part
# of, and nothing outside takes their place.
#
# A compiler leaves a copy of each inline function in every object that calls it, and the linker keeps one
# of them for the whole program. A client that is compiled with -march=native, -ffast-math or -O0 could so
# replace the code that the library runs by its own. In such an object these symbols are local; what is
# left to link against are the functions that are defined once. It takes GNU binutils.

# GNU's tools. With Clang, CMake names LLVM's, whose linker does not merge groups.
set(PVOL_BINUTILS_LINKER ${CMAKE_LINKER})
set(PVOL_BINUTILS_NM ${CMAKE_NM})
set(PVOL_BINUTILS_OBJCOPY ${CMAKE_OBJCOPY})
if(CMAKE_CXX_COMPILER_ID MATCHES Clang)
  foreach(tool LINKER:ld.bfd NM:nm OBJCOPY:objcopy)
    string(REPLACE ":" ";" tool ${tool})
    list(GET tool 0 variable)
    list(GET tool 1 name)
    unset(PVOL_BINUTILS_${variable})
    set(names ${CMAKE_LIBRARY_ARCHITECTURE}-${name})
    if(NOT CMAKE_CROSSCOMPILING)
      list(APPEND names ${name})
    endif()
    find_program(PVOL_BINUTILS_${variable} NAMES ${names})
  endforeach()
endif()

# RESULT becomes true where objects can hide symbols. Sanitizers need all symbols as they are.
function(pvol_can_hide_symbols RESULT)
  set(can FALSE)
  if(CMAKE_SYSTEM_NAME STREQUAL Linux AND PVOL_BINUTILS_OBJCOPY AND PVOL_BINUTILS_NM AND PVOL_BINUTILS_LINKER
      AND NOT PVOL_SANITIZE AND NOT PVOL_THREAD_SANITIZE AND NOT PVOL_FUZZ)
    execute_process(COMMAND ${PVOL_BINUTILS_LINKER} --help OUTPUT_VARIABLE help ERROR_QUIET)
    if(help MATCHES "force-group-allocation")
      set(can TRUE)
    else()
      message(STATUS "Objects hide no symbols, and flights are for the oldest processors: no GNU binutils")
    endif()
  endif()
  set(${RESULT} ${can} PARENT_SCOPE)
endfunction()

# RESULT becomes the objects to link: NAME.o made of all of them, or where that cannot be, they
# themselves.
function(pvol_self_contained RESULT NAME)
  set(objects ${ARGN})
  if(NOT PVOL_HIDES_SYMBOLS)
    set(${RESULT} ${objects} PARENT_SCOPE)
    return()
  endif()
  set(object ${CMAKE_CURRENT_BINARY_DIR}/self_contained/${NAME}.o)
  set(list ${CMAKE_CURRENT_BINARY_DIR}/self_contained/${NAME}.objects)
  file(GENERATE OUTPUT ${list} CONTENT "$<JOIN:${objects},\n>\n")
  add_custom_command(OUTPUT ${object}
    COMMAND ${CMAKE_COMMAND} -D LINKER=${PVOL_BINUTILS_LINKER} -D NM=${PVOL_BINUTILS_NM}
      -D OBJCOPY=${PVOL_BINUTILS_OBJCOPY} -D OBJECTS=${list} -D SELF_CONTAINED=${object}
      -P ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/hide_symbols.cmake
    DEPENDS ${objects} ${list} ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/hide_symbols.cmake
    COMMENT "Hiding symbols of ${NAME}.o" VERBATIM)
  set_source_files_properties(${object} PROPERTIES EXTERNAL_OBJECT TRUE GENERATED TRUE)
  set(${RESULT} ${object} PARENT_SCOPE)
endfunction()

# RESULT becomes the objects for a static library: NAME_hidden.o of the self-contained object, or where there
# is none, the objects as they are. A plug-in that holds it neither shows the library's functions to others
# nor calls those of another library or of the program that loads it.
function(pvol_hidden RESULT NAME)
  set(objects ${ARGN})
  if(NOT PVOL_HIDES_SYMBOLS)
    set(${RESULT} ${objects} PARENT_SCOPE)
    return()
  endif()
  set(object ${CMAKE_CURRENT_BINARY_DIR}/self_contained/${NAME}_hidden.o)
  add_custom_command(OUTPUT ${object}
    COMMAND ${CMAKE_COMMAND} -D LINKER=${PVOL_BINUTILS_LINKER} -D NM=${PVOL_BINUTILS_NM}
      -D COMPILER=${CMAKE_CXX_COMPILER} -D OBJECT=${objects} -D HIDDEN=${object}
      -P ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/hide_object.cmake
    DEPENDS ${objects} ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/hide_object.cmake
    COMMENT "Making ${NAME}_hidden.o" VERBATIM)
  set_source_files_properties(${object} PROPERTIES EXTERNAL_OBJECT TRUE GENERATED TRUE)
  set(${RESULT} ${object} PARENT_SCOPE)
endfunction()
