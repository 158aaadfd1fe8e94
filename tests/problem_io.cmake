lcpbench_test(problem_errors LINK lcpbench_generators)
lcpbench_test(problem_io LINK lcpbench_generators)
target_compile_definitions(problem_io_test PRIVATE LCPBENCH_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
lcpbench_test(scenes_file LINK lcpbench_generators Threads::Threads)
target_compile_definitions(scenes_file_test PRIVATE LCPBENCH_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
lcpbench_test(problem_text_formats LINK lcpbench_generators)

# The published schema. Without the Python package jsonschema (python3-jsonschema) the test fails and says so.
find_package(Python3 REQUIRED COMPONENTS Interpreter)
add_executable(write_problem_files write_problem_files.cpp)
target_link_libraries(write_problem_files PRIVATE lcpbench_generators)
add_test(NAME problem_schema
         COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/problem_schema_test.py
                 ${PROJECT_SOURCE_DIR}/docs/schema/problem.schema.json ${PROJECT_SOURCE_DIR}/examples
                 $<TARGET_FILE:write_problem_files>)

add_subdirectory(fuzz)
