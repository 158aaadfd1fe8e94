lcpbench_test(quad LINK lcpbench_evaluation)
lcpbench_test(evaluation LINK lcpbench_evaluation)
lcpbench_test(verdict LINK lcpbench_evaluation SQLite::SQLite3)
target_compile_definitions(verdict_test PRIVATE LCPBENCH_VERDICTS_TABLE="${PROJECT_SOURCE_DIR}/docs/verdicts.md")
