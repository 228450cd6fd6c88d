# The oracle of the unit tests, in long double and in quadruple precision.
target_include_directories(bench_shapes PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/../core/geometry)
target_sources(bench_shapes PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/shapes_rods.cpp ${CMAKE_CURRENT_SOURCE_DIR}/shapes_cost.cpp
  ${CMAKE_CURRENT_SOURCE_DIR}/shapes_motion.cpp
  ${CMAKE_CURRENT_SOURCE_DIR}/shapes_terrain.cpp
  ${CMAKE_CURRENT_SOURCE_DIR}/heap_kinds.cpp)
# Peers on the same heaps in the same run.
if(NOT TARGET haptic_peers)
  add_subdirectory(${CMAKE_CURRENT_LIST_DIR}/../peers ${CMAKE_CURRENT_BINARY_DIR}/peers)
endif()
target_link_libraries(bench_shapes quadmath haptic_peers)
