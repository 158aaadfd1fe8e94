# The native solvers as a package for simulators: a header for C++, <lcpbench/lcpbench.h>, one for C, <lcpbench/lcpbench_c.h>,
# one static library, one CMake target lcpbench::native. Eigen and the standard library only, with its threads. Installed
# by `cmake --install BUILD`.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

get_property(natives GLOBAL PROPERTY LCPBENCH_NATIVE_SOLVERS)
_lcpbench_native_entries("${natives}" declarations entries)
_lcpbench_write_list(${PROJECT_BINARY_DIR}/generated/native_list.cpp "${declarations}" "${entries}")

get_property(engines GLOBAL PROPERTY LCPBENCH_ENGINES)
set(objects $<TARGET_OBJECTS:lcpbench_core> $<TARGET_OBJECTS:lcpbench_native>)
foreach(engine IN LISTS engines)
  list(APPEND objects $<TARGET_OBJECTS:${engine}>)
endforeach()

set(header ${PROJECT_BINARY_DIR}/include/lcpbench/lcpbench.h)
file(GLOB headers ${PROJECT_SOURCE_DIR}/core/*.h)
add_custom_command(
  OUTPUT ${header}
  COMMAND ${CMAKE_COMMAND} -DROOT=${PROJECT_SOURCE_DIR} -DINPUT=native/lcpbench.h -DOUTPUT=${header}
          -P ${PROJECT_SOURCE_DIR}/cmake/single_header.cmake
  DEPENDS ${PROJECT_SOURCE_DIR}/cmake/single_header.cmake ${PROJECT_SOURCE_DIR}/native/lcpbench.h ${headers}
  COMMENT "Writing lcpbench/lcpbench.h" VERBATIM)

set(c_header ${PROJECT_SOURCE_DIR}/native/lcpbench_c.h)
set(c_source ${PROJECT_SOURCE_DIR}/native/lcpbench_c.cpp)
set_source_files_properties(${c_source} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)  # the shared library has its own
configure_file(${c_header} ${PROJECT_BINARY_DIR}/include/lcpbench/lcpbench_c.h COPYONLY)

add_library(lcpbench_package STATIC ${PROJECT_BINARY_DIR}/generated/native_list.cpp ${c_source} ${header} ${objects})
add_library(lcpbench::native ALIAS lcpbench_package)
target_include_directories(lcpbench_package
  PRIVATE ${PROJECT_SOURCE_DIR}
  INTERFACE $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
target_link_libraries(lcpbench_package PUBLIC Eigen3::Eigen Threads::Threads)
target_compile_features(lcpbench_package INTERFACE cxx_std_20)
set_target_properties(lcpbench_package PROPERTIES EXPORT_NAME native OUTPUT_NAME lcpbench)

# The interface for C in a shared library that shows nothing else, for what loads libraries at run time.
if(CMAKE_POSITION_INDEPENDENT_CODE)
  set(shown ${PROJECT_BINARY_DIR}/generated/lcpbench_c.map)
  file(CONFIGURE OUTPUT ${shown} CONTENT "{ global: lcpbench_*; local: *; };\n")
  add_library(lcpbench_c SHARED ${c_source})
  add_library(lcpbench::c ALIAS lcpbench_c)
  target_include_directories(lcpbench_c PRIVATE ${PROJECT_SOURCE_DIR}
    INTERFACE $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(lcpbench_c PRIVATE $<BUILD_INTERFACE:lcpbench_package>)
  target_link_options(lcpbench_c PRIVATE LINKER:--version-script=${shown})
  set_target_properties(lcpbench_c PROPERTIES EXPORT_NAME c VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}
                        CXX_VISIBILITY_PRESET default)
  install(TARGETS lcpbench_c EXPORT lcpbench-targets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
endif()

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/lcpbench)
set(generated_dir ${PROJECT_BINARY_DIR}/generated/package)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/lcpbench-config.cmake.in ${generated_dir}/lcpbench-config.cmake
                              INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${generated_dir}/lcpbench-config-version.cmake COMPATIBILITY SameMajorVersion)
install(TARGETS lcpbench_package EXPORT lcpbench-targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
install(FILES ${header} ${c_header} ${PROJECT_SOURCE_DIR}/examples/capture/capture.h
        DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/lcpbench COMPONENT dev)
install(EXPORT lcpbench-targets NAMESPACE lcpbench:: DESTINATION ${package_dir} COMPONENT dev)
install(FILES ${generated_dir}/lcpbench-config.cmake ${generated_dir}/lcpbench-config-version.cmake
        DESTINATION ${package_dir} COMPONENT dev)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/NOTICE
        DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/liblcpbench-dev COMPONENT dev)
