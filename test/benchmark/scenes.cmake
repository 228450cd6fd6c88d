# The shipped scenes with their hands: it needs the scene loader.
if(NOT TARGET penalty_sim_scene)
  add_subdirectory(${CMAKE_CURRENT_LIST_DIR}/../../penalty_sim/scene ${CMAKE_CURRENT_BINARY_DIR}/penalty_sim_scene)
endif()
target_sources(bench_scenes PRIVATE ${CMAKE_CURRENT_LIST_DIR}/loop_rig.cpp ${CMAKE_CURRENT_LIST_DIR}/scenes_ticks.cpp)
target_link_libraries(bench_scenes penalty_sim_scene)
