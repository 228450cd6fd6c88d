# Where the libraries, headers and targets go: an install has both libraries.
include(GNUInstallDirs)
install(TARGETS haptic_core EXPORT haptic_core-targets
  LIBRARY DESTINATION lib ARCHIVE DESTINATION lib RUNTIME DESTINATION bin)
if(TARGET haptic_core_v3)
  install(TARGETS haptic_core_v3 LIBRARY DESTINATION lib/${HAPTIC_V3_FOLDER} NAMELINK_SKIP)
endif()
install(DIRECTORY haptic_core DESTINATION include FILES_MATCHING PATTERN "*.h")
install(EXPORT haptic_core-targets NAMESPACE haptic_core:: DESTINATION lib/cmake/haptic_core)
export(EXPORT haptic_core-targets NAMESPACE haptic_core:: FILE ${CMAKE_CURRENT_BINARY_DIR}/haptic_core-targets.cmake)
if(NOT HAPTIC_UNDER_CATKIN)
  install(FILES cmake/haptic_coreConfig.cmake DESTINATION lib/cmake/haptic_core)
endif()
install(FILES package.xml DESTINATION share/haptic_core)
