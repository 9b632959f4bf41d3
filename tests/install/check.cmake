# Installs the build into a scratch folder and builds and runs a program against what lies there.
# Called with -DBUILD=<build folder> -DSOURCE=<this folder> -DWORK=<scratch> -DCOMPILER=<C++ compiler>

function(run what)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${what}: exit ${status}\n${output}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
run("install" ${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
run("configure the consumer" ${CMAKE_COMMAND} -S ${SOURCE}/consumer -B ${WORK}/build -G Ninja
  -DCMAKE_PREFIX_PATH=${WORK}/prefix -DCMAKE_CXX_COMPILER=${COMPILER})
run("build the consumer" ${CMAKE_COMMAND} --build ${WORK}/build)
run("run the consumer" ${WORK}/build/consumer)
run("run the installed program" ${WORK}/prefix/bin/choreoscope --version)
execute_process(COMMAND ${WORK}/prefix/bin/choreoscope config show --config stage OUTPUT_VARIABLE shown)
if(NOT shown MATCHES "${WORK}/prefix/[^\n]*presets/stage.toml:")
  message(FATAL_ERROR "the installed program does not find its installed presets:\n${shown}")
endif()
file(REMOVE_RECURSE ${WORK})
