# Real processes on a pseudo-terminal: it needs the driver's libraries, as bench_faults does.
if(NOT TARGET spidar_transport)
  add_subdirectory(${CMAKE_CURRENT_LIST_DIR}/../../spidar_driver/transport ${CMAKE_CURRENT_BINARY_DIR}/spidar_transport)
endif()
target_include_directories(bench_faults_pair PRIVATE ${CMAKE_CURRENT_LIST_DIR}/../transport)
target_link_libraries(bench_faults_pair spidar_emulation)
