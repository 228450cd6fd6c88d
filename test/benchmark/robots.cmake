# The scene loader, which the core does not know, and the measurement that bench_articulated shares.
if(NOT TARGET penalty_sim_scene)
  add_subdirectory(${CMAKE_CURRENT_SOURCE_DIR}/../../penalty_sim/scene ${CMAKE_CURRENT_BINARY_DIR}/scene)
endif()
target_sources(bench_robots PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/articulated_robots.cpp)
target_link_libraries(bench_robots penalty_sim_scene)
