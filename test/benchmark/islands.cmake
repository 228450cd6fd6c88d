# The scene loader.
if(NOT TARGET penalty_sim_scene)
  add_subdirectory(${CMAKE_CURRENT_SOURCE_DIR}/../../penalty_sim/scene ${CMAKE_CURRENT_BINARY_DIR}/scene)
endif()
target_sources(bench_islands PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/islands_scenes.cpp ${CMAKE_CURRENT_SOURCE_DIR}/loop_rig.cpp)
target_link_libraries(bench_islands penalty_sim_scene)
