# Boards in software, as bench_faults has them.
if(NOT TARGET spidar_transport)
  add_subdirectory(${CMAKE_CURRENT_LIST_DIR}/../../spidar_driver/transport ${CMAKE_CURRENT_BINARY_DIR}/spidar_transport)
endif()
target_sources(bench_faults_device PRIVATE ${CMAKE_CURRENT_LIST_DIR}/fault_rig.cpp ${CMAKE_CURRENT_LIST_DIR}/fault_campaign.cpp)
target_include_directories(bench_faults_device PRIVATE ${CMAKE_CURRENT_LIST_DIR}/../transport)
target_link_libraries(bench_faults_device spidar_emulation)
