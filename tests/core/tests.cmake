add_test(NAME layers COMMAND ${CMAKE_COMMAND} -DROOT=${PROJECT_SOURCE_DIR} -P ${CMAKE_CURRENT_SOURCE_DIR}/core/layers.cmake)
add_test(NAME one_definition
         COMMAND ${CMAKE_COMMAND} -DROOT=${PROJECT_SOURCE_DIR} -P ${CMAKE_CURRENT_SOURCE_DIR}/core/one_definition.cmake)
lcpbench_test(spec LINK lcpbench_core)
lcpbench_test(settings LINK lcpbench_core)
lcpbench_test(contact_problem LINK lcpbench_core)
lcpbench_test(exact_inertia LINK lcpbench_core)
lcpbench_test(solver LINK lcpbench_core)
lcpbench_test(isa LINK lcpbench_core)
lcpbench_test(islands LINK lcpbench_core)
lcpbench_test(utf8 LINK lcpbench_core)
lcpbench_test(suggestion LINK lcpbench_core)
lcpbench_test(warm_start LINK lcpbench_core)
target_sources(warm_start_test PRIVATE support/allocation_counter.cpp)

lcpbench_test(whole_file LINK lcpbench_io)
lcpbench_test(problem_errors LINK lcpbench_generators)
lcpbench_test(problem_io LINK lcpbench_generators)
target_compile_definitions(problem_io_test PRIVATE LCPBENCH_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
lcpbench_test(scenes_file LINK lcpbench_generators Threads::Threads)
target_compile_definitions(scenes_file_test PRIVATE LCPBENCH_SOURCE_DIR="${PROJECT_SOURCE_DIR}")

# The header for engines: C99, and C++; the example programs of the engines that are here.
lcpbench_test(capture LINK lcpbench_io)
find_program(C_COMPILER NAMES cc gcc clang)
file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/capture.c
     "#include \"${PROJECT_SOURCE_DIR}/examples/capture/capture.h\"\nint main(void) { return lcpbench_capture_close(NULL) == 0; }\n")
add_test(NAME capture_c99
         COMMAND ${C_COMPILER} -std=c99 -pedantic-errors -Wall -Wextra -Werror -Wsystem-headers -fsyntax-only
                 ${CMAKE_CURRENT_BINARY_DIR}/capture.c)
set(capture_examples "")
function(lcpbench_capture_example engine)
  add_executable(capture_${engine} ${PROJECT_SOURCE_DIR}/examples/capture/${engine}.cpp)
  target_link_libraries(capture_${engine} PRIVATE ${ARGN})
  set_target_properties(capture_${engine} PROPERTIES COMPILE_OPTIONS "")  # a user's own program, with a user's warnings
  add_dependencies(capture_test capture_${engine})
  set(capture_examples "${capture_examples}$<TARGET_FILE:capture_${engine}>:" PARENT_SCOPE)
endfunction()
if(TARGET PkgConfig::ODE)
  lcpbench_capture_example(ode PkgConfig::ODE)
endif()
if(TARGET PkgConfig::BULLET)
  lcpbench_capture_example(bullet PkgConfig::BULLET)
endif()
find_library(MUJOCO_LIBRARY mujoco)
if(MUJOCO_LIBRARY)
  lcpbench_capture_example(mujoco ${MUJOCO_LIBRARY})
endif()
target_compile_definitions(capture_test PRIVATE CAPTURE_EXAMPLES="${capture_examples}")

# Files that fclib itself writes (libfclib-dev).
find_library(FCLIB_LIBRARY fclib)
if(TARGET lcpbench_fclib AND FCLIB_LIBRARY)
  lcpbench_test(fclib LINK lcpbench_fclib ${FCLIB_LIBRARY})
  target_compile_definitions(fclib_test PRIVATE LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>")
  add_dependencies(fclib_test lcpbench lcpbench-import-fclib)
endif()

lcpbench_test(problem_text_formats LINK lcpbench_generators)

# The published schema. Without the Python package jsonschema (python3-jsonschema) the test fails and says so.
find_package(Python3 REQUIRED COMPONENTS Interpreter)
add_executable(write_problem_files core/write_problem_files.cpp)
target_link_libraries(write_problem_files PRIVATE lcpbench_generators)
add_test(NAME problem_schema
         COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/core/problem_schema_test.py
                 ${PROJECT_SOURCE_DIR}/docs/schema/problem.schema.json ${PROJECT_SOURCE_DIR}/examples
                 $<TARGET_FILE:write_problem_files>)

add_subdirectory(fuzz)
