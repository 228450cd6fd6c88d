# The oracle of the unit tests, and ODE beside ours.
target_include_directories(bench_round PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/../core/geometry ${CMAKE_CURRENT_SOURCE_DIR}/..)
target_sources(bench_round PRIVATE
  ${CMAKE_CURRENT_SOURCE_DIR}/round_peers.cpp ${CMAKE_CURRENT_SOURCE_DIR}/round_motion.cpp ${CMAKE_CURRENT_SOURCE_DIR}/round_many.cpp)
target_link_libraries(bench_round quadmath)
find_package(PkgConfig QUIET)
if(PkgConfig_FOUND)
  pkg_check_modules(ODE QUIET IMPORTED_TARGET ode)
endif()
if(ODE_FOUND)
  target_link_libraries(bench_round PkgConfig::ODE)
  target_compile_definitions(bench_round PRIVATE HAPTIC_HAVE_ODE)
endif()
# ODE on the same scenes in the same run.
if(NOT TARGET haptic_peers)
  add_subdirectory(${CMAKE_CURRENT_LIST_DIR}/../peers ${CMAKE_CURRENT_BINARY_DIR}/peers)
endif()
target_link_libraries(bench_round haptic_peers)
