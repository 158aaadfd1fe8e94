# The program, its manual and completions as installed files, and two Debian packages: `cpack` in the build folder makes
# lcpbench_*.deb, the program with its workers, and liblcpbench-dev_*.deb, the package for simulators. `cmake --install`
# without a component leaves the program out.
set(manual ${PROJECT_BINARY_DIR}/manual)
set(pages ${manual}/lcpbench.1 ${manual}/lcpbench ${manual}/_lcpbench)
add_custom_command(
  OUTPUT ${pages}
  COMMAND bash ${PROJECT_SOURCE_DIR}/cmake/manual.sh $<TARGET_FILE:lcpbench> ${pages}
  DEPENDS lcpbench ${PROJECT_SOURCE_DIR}/cmake/manual.sh
  COMMENT "Writing the man page and the completions" VERBATIM)
add_custom_target(lcpbench_manual ALL DEPENDS ${pages})

# The program looks for its workers beside itself, where the link in bin leads.
set(program COMPONENT program EXCLUDE_FROM_ALL)
get_target_property(engines lcpbench_engines MANUALLY_ADDED_DEPENDENCIES)
foreach(target IN ITEMS lcpbench ${LCPBENCH_WORKERS} ${engines})
  if(TARGET ${target})
    install(TARGETS ${target} RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/lcpbench ${program})
  endif()
endforeach()
file(MAKE_DIRECTORY ${manual}/bin)
file(CREATE_LINK ../${CMAKE_INSTALL_LIBEXECDIR}/lcpbench/lcpbench ${manual}/bin/lcpbench SYMBOLIC)
install(FILES ${manual}/bin/lcpbench DESTINATION ${CMAKE_INSTALL_BINDIR} ${program})
install(FILES ${manual}/lcpbench.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 ${program})
install(FILES ${manual}/lcpbench DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions ${program})
install(FILES ${manual}/_lcpbench DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions ${program})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/NOTICE
        DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/lcpbench ${program})

set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL program dev)
set(CPACK_PACKAGE_CONTACT "The lcpbench maintainers <maintainers@lcpbench.invalid>")
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME lcpbench)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS libmujoco-samples)
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "Compares LCP and contact solvers")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME liblcpbench-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libeigen3-dev (>= 3.4)")
set(CPACK_COMPONENT_DEV_DESCRIPTION "Contact solvers of lcpbench for simulators: header and static library")
include(CPack)
