# The god object stands beside the benchmarks that measure it.
target_sources(core_peers_test PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/../benchmark/god_object.cpp
  ${CMAKE_CURRENT_SOURCE_DIR}/../benchmark/triangle_tree.cpp)
