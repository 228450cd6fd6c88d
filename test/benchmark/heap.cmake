# Peers on the same scenes in the same run.
if(NOT TARGET haptic_peers)
  add_subdirectory(${CMAKE_CURRENT_LIST_DIR}/../peers ${CMAKE_CURRENT_BINARY_DIR}/peers)
endif()
target_sources(bench_heap PRIVATE ${CMAKE_CURRENT_LIST_DIR}/heap_kinds.cpp)
target_link_libraries(bench_heap haptic_peers)
