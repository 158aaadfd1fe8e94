add_test(NAME layers COMMAND ${CMAKE_COMMAND} -DROOT=${PROJECT_SOURCE_DIR} -P ${CMAKE_CURRENT_SOURCE_DIR}/core/layers.cmake)
add_test(NAME one_definition
         COMMAND ${CMAKE_COMMAND} -DROOT=${PROJECT_SOURCE_DIR} -P ${CMAKE_CURRENT_SOURCE_DIR}/core/one_definition.cmake)
lcpbench_room(core LINK lcpbench_core lcpbench_generators lcpbench_io Threads::Threads
              DEFINE LCPBENCH_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
foreach(test spec settings contact_problem solver isa islands utf8 suggestion warm_start whole_file
        problem_errors problem_io problem_text_formats scenes_file)
  lcpbench_test(${test})
endforeach()

# The header for engines: C99, and C++; the example programs of the engines that are here.
lcpbench_test(capture)
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
  add_dependencies(core_tests capture_${engine})
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
target_compile_definitions(core_tests PRIVATE CAPTURE_EXAMPLES="${capture_examples}")

# The published schema. Without the Python package jsonschema (python3-jsonschema) the test fails and says so.
find_package(Python3 REQUIRED COMPONENTS Interpreter)
add_executable(write_problem_files core/write_problem_files.cpp)
target_link_libraries(write_problem_files PRIVATE lcpbench_generators)
add_test(NAME problem_schema
         COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/core/problem_schema_test.py
                 ${PROJECT_SOURCE_DIR}/docs/schema/problem.schema.json ${PROJECT_SOURCE_DIR}/examples
                 $<TARGET_FILE:write_problem_files>)

add_subdirectory(fuzz)
