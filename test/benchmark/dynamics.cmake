# Peers on the same scenes in the same run.
if(NOT TARGET haptic_peers)
  add_subdirectory(${CMAKE_CURRENT_LIST_DIR}/../peers ${CMAKE_CURRENT_BINARY_DIR}/peers)
endif()
target_sources(bench_dynamics PRIVATE ${CMAKE_CURRENT_LIST_DIR}/dynamics_accuracy.cpp
  ${CMAKE_CURRENT_LIST_DIR}/dynamics_friction.cpp ${CMAKE_CURRENT_LIST_DIR}/dynamics_speed.cpp)
target_link_libraries(bench_dynamics haptic_peers)
