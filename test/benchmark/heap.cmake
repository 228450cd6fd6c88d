# Peers on the same scenes in the same run.
if(NOT TARGET haptic_peers)
  add_subdirectory(${CMAKE_CURRENT_LIST_DIR}/../peers ${CMAKE_CURRENT_BINARY_DIR}/peers)
endif()
target_link_libraries(bench_heap haptic_peers)
