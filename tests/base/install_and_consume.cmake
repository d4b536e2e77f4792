# Run by ctest as `cmake -D ... -P`: installs into a folder of its own and builds and runs, against that alone, the
# project in consumer/.
#   SOURCE        the project's root              WORK         folder to work in
#   WHOLE_BUILD   build folder to install all of; empty: builds and installs `order` alone, with the packages that it
#                 must not need hidden
#   COMPILER, LAUNCHER, BUILD_TYPE, SANITIZE      what the tests were built with
file(REMOVE_RECURSE ${WORK}/installed ${WORK}/consumer)

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

set(configure ${CMAKE_COMMAND} -G Ninja -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}
              -DCMAKE_BUILD_TYPE=${BUILD_TYPE})
set(hidden)
if(WHOLE_BUILD)
  set(whole ON)
  set(build ${WHOLE_BUILD})
else()
  set(whole OFF)
  set(build ${WORK}/order)
  file(REMOVE ${build}/CMakeCache.txt)  # packages hidden by an earlier version of this file would stay so
  foreach(package embree OpenMesh OpenImageIO Boost TinyGLTF nlohmann_json CLI11 GTest benchmark)
    list(APPEND hidden -DCMAKE_DISABLE_FIND_PACKAGE_${package}=ON)
  endforeach()
  run(${configure} --no-warn-unused-cli ${hidden} -S ${SOURCE} -B ${build} -DFACETSORT_COMPONENTS=order
      -DFACETSORT_WARNINGS_AS_ERRORS=ON -DFACETSORT_SANITIZE=${SANITIZE})
  run(${CMAKE_COMMAND} --build ${build})
endif()
run(${CMAKE_COMMAND} --install ${build} --prefix ${WORK}/installed)

set(flags)
if(SANITIZE)
  set(flags -fsanitize=${SANITIZE})
endif()
run(${configure} --no-warn-unused-cli ${hidden} -S ${SOURCE}/tests/base/consumer -B ${WORK}/consumer
    -DCMAKE_PREFIX_PATH=${WORK}/installed -DCMAKE_CXX_FLAGS=${flags} -DWHOLE_LIBRARY=${whole})
run(${CMAKE_COMMAND} --build ${WORK}/consumer)
run(${CMAKE_CTEST_COMMAND} --test-dir ${WORK}/consumer --output-on-failure --no-tests=error)
