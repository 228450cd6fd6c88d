# Peers on the same scenes in the same run.
if(NOT TARGET haptic_peers)
  add_subdirectory(${CMAKE_CURRENT_LIST_DIR}/../peers ${CMAKE_CURRENT_BINARY_DIR}/peers)
endif()
target_sources(bench_extreme PRIVATE ${CMAKE_CURRENT_LIST_DIR}/extreme_rigid.cpp
  ${CMAKE_CURRENT_LIST_DIR}/extreme_certificate.cpp ${CMAKE_CURRENT_LIST_DIR}/extreme_allocations.cpp
  ${CMAKE_CURRENT_LIST_DIR}/extreme_choice.cpp)
target_link_libraries(bench_extreme haptic_peers)
