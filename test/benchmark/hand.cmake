target_sources(bench_hand PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/hand_thin.cpp)
