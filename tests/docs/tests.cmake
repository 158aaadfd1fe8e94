# The documents: links, generated tables, tutorials, and the solver that one page has its reader write.
find_package(Python3 REQUIRED COMPONENTS Interpreter)
set(docs_test ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/docs/docs_test.py)
add_test(NAME docs_links COMMAND ${docs_test} links)
add_test(NAME docs_tables COMMAND ${docs_test} tables $<TARGET_FILE:lcpbench>)
find_program(GIT git)
if(GIT)
  add_test(NAME docs_age COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/docs/age_test.sh ${PROJECT_SOURCE_DIR}/results/age.sh)
endif()
add_test(NAME docs_specs COMMAND ${docs_test} specs $<TARGET_FILE:lcpbench>)
foreach(tutorial first-study bring-your-problem bring-your-solver)
  add_test(NAME docs_${tutorial}
           COMMAND ${docs_test} tutorial ${PROJECT_SOURCE_DIR}/docs/tutorial/${tutorial}.md $<TARGET_FILE:lcpbench>)
endforeach()

# README's Python for a robot needs an engine: as ```py it is no cell.
add_test(NAME docs_readme COMMAND ${docs_test} tutorial ${PROJECT_SOURCE_DIR}/README.md $<TARGET_FILE:lcpbench>)

add_test(NAME docs_report-a-failing-case
         COMMAND ${docs_test} tutorial ${PROJECT_SOURCE_DIR}/docs/howto/report-a-failing-case.md $<TARGET_FILE:lcpbench>)

# The first C++ block of the page is compiled as it stands there.
set(page ${PROJECT_SOURCE_DIR}/docs/howto/adding-a-solver.md)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${page})
file(READ ${page} text)
string(FIND "${text}" "```cpp\n" begin)
string(SUBSTRING "${text}" ${begin} -1 text)
string(FIND "${text}" "\n```\n" end)
math(EXPR length "${end} - 7")
string(SUBSTRING "${text}" 7 ${length} code)
file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/added_solver.cpp CONTENT "${code}" @ONLY)
lcpbench_room(docs)
lcpbench_test(added_solver APART WITH ${CMAKE_CURRENT_BINARY_DIR}/added_solver.cpp LINK lcpbench_core)
