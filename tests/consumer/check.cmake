# Installs a build of pvol into a folder of its own, then configures, builds and runs the consumers
# against it. cmake -D BUILD=... -D WORK=... -D GENERATOR=... -D COMPILER=... -D C_COMPILER=...
# -D SAMPLES=... -D SELF_CONTAINED=... -P check.cmake
file(REMOVE_RECURSE ${WORK})

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK}/build -G ${GENERATOR}
  -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_C_COMPILER=${C_COMPILER}
  -D CMAKE_PREFIX_PATH=${WORK}/prefix -D CMAKE_BUILD_TYPE=Release -D SELF_CONTAINED=${SELF_CONTAINED})
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${WORK}/build/consumer)
run(${WORK}/build/c_client_static)
run(${WORK}/build/c_client_shared)
run(${WORK}/build/recipes)
run(${WORK}/build/host ${WORK}/build/plugin.so)

# Clouds and rays do without Embree, which pictures need.
foreach(program c_client_static c_client_shared)
  execute_process(COMMAND ldd ${WORK}/build/${program} OUTPUT_VARIABLE needed COMMAND_ERROR_IS_FATAL ANY)
  if(needed MATCHES "embree")
    message(FATAL_ERROR "${program} needs Embree:\n${needed}")
  endif()
endforeach()

# Without CMake: by pkg-config and the shared library.
file(GLOB_RECURSE package ${WORK}/prefix/pvol.pc)
cmake_path(GET package PARENT_PATH package)
run(sh -c "${C_COMPILER} -std=c99 ${CMAKE_CURRENT_LIST_DIR}/c_client.c -o ${WORK}/build/c_plain \
  $(PKG_CONFIG_PATH=${package} pkg-config --cflags --libs pvol) -lm \
  -Wl,-rpath,$(PKG_CONFIG_PATH=${package} pkg-config --variable=libdir pvol)")
run(${WORK}/build/c_plain)
run(sh -c "${C_COMPILER} -std=c99 ${CMAKE_CURRENT_LIST_DIR}/c_client.c -o ${WORK}/build/c_plain_render \
  $(PKG_CONFIG_PATH=${package} pkg-config --cflags --libs pvol_render) -lm \
  -Wl,-rpath,$(PKG_CONFIG_PATH=${package} pkg-config --variable=libdir pvol_render)")
run(${WORK}/build/c_plain_render)

# Inline functions of the library are its own: clients of any options get the same bits.
foreach(kind plain fast unoptimised)
  execute_process(COMMAND ${WORK}/build/odd_client_${kind}
    OUTPUT_VARIABLE hash_${kind} COMMAND_ERROR_IS_FATAL ANY)
  message(STATUS "results in the client ${kind}: ${hash_${kind}}")
  if(SELF_CONTAINED AND NOT hash_${kind} STREQUAL hash_plain)
    message(FATAL_ERROR "the library's results hang on how its client was compiled")
  endif()
endforeach()

# A path tracer of somebody else's against pvol-render.
if(EXISTS ${WORK}/build/path_tracer)
  set(tools ${WORK}/prefix/bin)
  run(${tools}/pvol-fit ${SAMPLES}/cumulus.toml -o ${WORK}/cumulus.pvol)
  run(${tools}/pvol-render ${SAMPLES}/peer_scene.toml --set volume.file=${WORK}/cumulus.pvol
    --set medium.g=0.5 --size 32x32 --spp 512 -o ${WORK}/reference.exr)
  execute_process(COMMAND oiiotool --dumpdata ${WORK}/reference.exr
    OUTPUT_FILE ${WORK}/reference.txt COMMAND_ERROR_IS_FATAL ANY)
  run(${WORK}/build/path_tracer ${WORK}/cumulus.pvol ${WORK}/reference.txt)
endif()
