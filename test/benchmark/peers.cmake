# The report's scenes and peers, outside of the report, and shipped scenes, which need the loader.
if(NOT TARGET penalty_sim_scene)
  add_subdirectory(${CMAKE_CURRENT_LIST_DIR}/../../penalty_sim/scene ${CMAKE_CURRENT_BINARY_DIR}/penalty_sim_scene)
endif()
if(NOT TARGET haptic_peers)
  add_subdirectory(${CMAKE_CURRENT_LIST_DIR}/../peers ${CMAKE_CURRENT_BINARY_DIR}/peers)
endif()
set(report ${CMAKE_CURRENT_LIST_DIR}/../report)
target_sources(bench_peers PRIVATE ${CMAKE_CURRENT_LIST_DIR}/peers_rigid.cpp ${CMAKE_CURRENT_LIST_DIR}/peers_published.cpp
  ${CMAKE_CURRENT_LIST_DIR}/peers_contactbench.cpp ${CMAKE_CURRENT_LIST_DIR}/peers_cenic.cpp
  ${CMAKE_CURRENT_LIST_DIR}/peers_haptic.cpp ${CMAKE_CURRENT_LIST_DIR}/peers_two_hands.cpp ${CMAKE_CURRENT_LIST_DIR}/round_many.cpp
  ${report}/run_case.cpp ${report}/motion_scenes.cpp ${report}/published_scenes.cpp
  ${report}/contactbench_scenes.cpp ${report}/cenic_scenes.cpp)
target_include_directories(bench_peers PRIVATE ${report})
target_link_libraries(bench_peers penalty_sim_scene haptic_peers)
