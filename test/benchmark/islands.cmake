# The scene loader.
if(NOT TARGET penalty_sim_scene)
  add_subdirectory(${CMAKE_CURRENT_SOURCE_DIR}/../../penalty_sim/scene ${CMAKE_CURRENT_BINARY_DIR}/scene)
endif()
if(NOT TARGET haptic_peers)
  add_subdirectory(${CMAKE_CURRENT_LIST_DIR}/../peers ${CMAKE_CURRENT_BINARY_DIR}/peers)
endif()
target_sources(bench_islands PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/islands_scenes.cpp ${CMAKE_CURRENT_SOURCE_DIR}/loop_rig.cpp
  ${CMAKE_CURRENT_SOURCE_DIR}/islands_peers.cpp ${CMAKE_CURRENT_SOURCE_DIR}/islands_deadline.cpp)
target_link_libraries(bench_islands penalty_sim_scene haptic_peers)
