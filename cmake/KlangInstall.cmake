# Headers keep their path from the root below include/klangprobe; find_package(klangprobe) gives klang::mesh, klang::fit, ...
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
get_property(libraries GLOBAL PROPERTY KLANG_LIBRARIES)
get_property(folders GLOBAL PROPERTY KLANG_HEADER_FOLDERS)

install(TARGETS ${libraries} klang_flags EXPORT klangprobe-targets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT libklangprobe-dev
  INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/klangprobe)
foreach(folder ${folders})
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${folder}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/klangprobe/${folder}
    COMPONENT libklangprobe-dev FILES_MATCHING PATTERN "*.hpp" PATTERN detail EXCLUDE)
endforeach()
install(EXPORT klangprobe-targets NAMESPACE klang:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/klangprobe
  COMPONENT libklangprobe-dev)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/klangprobe-config.cmake.in
  ${PROJECT_BINARY_DIR}/klangprobe-config.cmake INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/klangprobe)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/klangprobe-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/klangprobe-config.cmake ${PROJECT_BINARY_DIR}/klangprobe-config-version.cmake
  ${PROJECT_SOURCE_DIR}/cmake/KlangDependencies.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/klangprobe COMPONENT libklangprobe-dev)
set(KLANG_PACKAGES klangprobe libklangprobe-dev)
if(KLANG_WITH_PYTHON)
  list(APPEND KLANG_PACKAGES python3-klangprobe)
endif()
if(KLANG_WITH_MPI)
  list(APPEND KLANG_PACKAGES klangprobe-mpi)
endif()
foreach(package ${KLANG_PACKAGES})
  install(FILES ${PROJECT_SOURCE_DIR}/cmake/debian/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${package})
endforeach()
include(KlangPackages)
