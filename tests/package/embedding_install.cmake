cmake_policy(VERSION 3.22)
# Installs the package into a folder of its own, builds examples/embed against it as an outside project, runs it, and
# looks at what the program needs at run time. Then once more for this very processor, whose wider registers may change
# how Eigen aligns its memory: that program must work or say so, not crash.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  set(result "${result}" PARENT_SCOPE)
  set(output "${output}" PARENT_SCOPE)
endfunction()

function(must_run)
  run(${ARGN})
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${ARGN}\nended in '${result}':\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

function(build_example name flags)
  must_run(${CMAKE_COMMAND} -S ${EXAMPLE} -B ${WORK}/${name} -G ${GENERATOR} -DCMAKE_BUILD_TYPE=Release
           -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_PREFIX_PATH=${WORK}/prefix "-DCMAKE_CXX_FLAGS=${flags}")
  must_run(${CMAKE_COMMAND} --build ${WORK}/${name})
endfunction()

set(right_speed "speed 0\\.589702 m/s, g \\(sin - mu cos\\) = 0\\.589702 m/s")
file(REMOVE_RECURSE ${WORK})
must_run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)

# EIGEN_MPL2_ONLY: an include of anything in Eigen under a stricter licence is an error.
build_example(plain "-DEIGEN_MPL2_ONLY -Wall -Wextra -Werror")
must_run(${WORK}/plain/embed)
if(NOT output MATCHES "${right_speed}")
  message(FATAL_ERROR "the example says: ${output}")
endif()

must_run(${READELF} -d ${WORK}/plain/embed)
string(REGEX MATCHALL "Shared library: \\[[^]]*\\]" needed "${output}")
if(NOT needed)
  message(FATAL_ERROR "no shared library in:\n${output}")
endif()
foreach(library IN LISTS needed)
  if(NOT library MATCHES "\\[(libstdc\\+\\+|libm|libgcc_s|libc|ld-linux[^]]*)\\.so")
    message(FATAL_ERROR "the example needs more than the standard library: ${library}")
  endif()
endforeach()

build_example(native -march=native)
run(${WORK}/native/embed)
set(works FALSE)
if(result EQUAL 0 AND output MATCHES "${right_speed}")
  set(works TRUE)
endif()
if(NOT works AND NOT output MATCHES "build both with the same -m options")
  message(FATAL_ERROR "with -march=native the example ended in '${result}' and said: ${output}")
endif()
message(STATUS "installed, found, built, run; needs: ${needed}")
