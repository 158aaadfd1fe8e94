find_package(LibXml2 REQUIRED)  # an independent reader of the pages and pictures
lcpbench_test(statistics LINK lcpbench_statistics)
lcpbench_test(statistics_coverage LINK lcpbench_statistics)
lcpbench_test(comparison LINK lcpbench_report)
lcpbench_test(comparison_report LINK lcpbench_report)
lcpbench_test(summary LINK lcpbench_report)
lcpbench_test(report LINK lcpbench_report LibXml2::LibXml2)
