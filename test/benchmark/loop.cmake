# The loop on the scenes of urdf/scenes: it needs the scene loader.
if(NOT TARGET penalty_sim_scene)
  add_subdirectory(${CMAKE_CURRENT_LIST_DIR}/../../penalty_sim/scene ${CMAKE_CURRENT_BINARY_DIR}/penalty_sim_scene)
endif()
target_sources(bench_loop PRIVATE ${CMAKE_CURRENT_LIST_DIR}/loop_rig.cpp ${CMAKE_CURRENT_LIST_DIR}/loop_stability.cpp
  ${CMAKE_CURRENT_LIST_DIR}/loop_gear.cpp)
target_link_libraries(bench_loop penalty_sim_scene)
