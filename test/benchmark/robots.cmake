# The scene loader, which the core does not know, and the measurement of published robots.
if(NOT TARGET penalty_sim_scene)
  add_subdirectory(${CMAKE_CURRENT_SOURCE_DIR}/../../penalty_sim/scene ${CMAKE_CURRENT_BINARY_DIR}/scene)
endif()
target_sources(bench_${name} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/articulated_robots.cpp)
target_link_libraries(bench_${name} penalty_sim_scene)
