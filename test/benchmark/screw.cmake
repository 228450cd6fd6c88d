# Screws from scene files, one of them with a hand: it needs the scene loader.
if(NOT TARGET penalty_sim_scene)
  add_subdirectory(${CMAKE_CURRENT_LIST_DIR}/../../penalty_sim/scene ${CMAKE_CURRENT_BINARY_DIR}/penalty_sim_scene)
endif()
target_sources(bench_screw PRIVATE ${CMAKE_CURRENT_LIST_DIR}/loop_rig.cpp)
target_link_libraries(bench_screw penalty_sim_scene)
