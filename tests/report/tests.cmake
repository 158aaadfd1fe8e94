lcpbench_test(statistics LINK lcpbench_statistics)
lcpbench_test(statistics_coverage LINK lcpbench_statistics)
set_tests_properties(statistics_coverage PROPERTIES LABELS release-only)  # a simulation of what `statistics` tests
lcpbench_test(compare LINK lcpbench_report)
target_compile_definitions(compare_test PRIVATE LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>")
add_dependencies(compare_test lcpbench)
lcpbench_test(summary LINK lcpbench_report)
lcpbench_test(damaged_store LINK lcpbench_report)
lcpbench_test(report LINK lcpbench_report)
lcpbench_test(report_text LINK lcpbench_report)
lcpbench_test(scenes_report LINK lcpbench_report)
lcpbench_test(paper_claims LINK lcpbench_report)
lcpbench_test(hard_report LINK lcpbench_report)
lcpbench_test(reliability LINK lcpbench_report)
lcpbench_test(coverage LINK lcpbench_runner lcpbench_report lcpbench_study lcpbench_solver_list)
target_compile_definitions(coverage_test PRIVATE LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>")
add_dependencies(coverage_test lcpbench)
lcpbench_test(screen LINK lcpbench_inspect lcpbench_study lcpbench_core)
target_compile_definitions(screen_test PRIVATE LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>")
add_dependencies(screen_test lcpbench)
lcpbench_test(hard_study SLOW LINK lcpbench_study)
target_compile_definitions(hard_study_test PRIVATE LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>"
                                                   HARD_PLAN="${PROJECT_SOURCE_DIR}/study/run/plans/hard.json")
add_dependencies(hard_study_test lcpbench)
lcpbench_test(paper_tables LINK lcpbench_report)
target_compile_definitions(paper_tables_test PRIVATE LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>")
add_dependencies(paper_tables_test lcpbench)

# The program of docs/howto/report.md, run on a report made for it.
add_test(NAME tables_page
         COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/report/tables_page_test.py $<TARGET_FILE:lcpbench>
                 ${CMAKE_SOURCE_DIR}/docs/howto/report.md)

# The report's page as people use it, in Chromium; skipped where that is missing.
add_executable(page_choices ${CMAKE_CURRENT_SOURCE_DIR}/report/page/choices.cpp)
target_link_libraries(page_choices PRIVATE lcpbench_report)
lcpbench_handles_text(page_choices)
add_test(NAME page
         COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/report/page/page_test.py $<TARGET_FILE:lcpbench>
                 $<TARGET_FILE:page_choices>)
set_tests_properties(page PROPERTIES SKIP_RETURN_CODE 77 LABELS release-only)

add_test(NAME page_scenes
         COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/report/page/scene_test.py $<TARGET_FILE:lcpbench>)
set_tests_properties(page_scenes PROPERTIES SKIP_RETURN_CODE 77 LABELS release-only)

# The committed page is what its sources make; skipped where npm's packages are missing.
add_test(NAME page_bundle WORKING_DIRECTORY ${CMAKE_SOURCE_DIR}/study/report/page
         COMMAND sh -c "test -d node_modules && command -v node || exit 77; node build.js --check")
set_tests_properties(page_bundle PROPERTIES SKIP_RETURN_CODE 77)
