# The fault benchmark drives the UART wire on emulated boards: it needs the driver's libraries.
if(NOT TARGET spidar_transport)
  add_subdirectory(${CMAKE_CURRENT_LIST_DIR}/../../spidar_driver/transport ${CMAKE_CURRENT_BINARY_DIR}/spidar_transport)
endif()
target_sources(bench_faults PRIVATE ${CMAKE_CURRENT_LIST_DIR}/fault_rig.cpp
  ${CMAKE_CURRENT_LIST_DIR}/fault_campaign.cpp
  ${CMAKE_CURRENT_LIST_DIR}/checked_link.cpp ${CMAKE_CURRENT_LIST_DIR}/twin_faults.cpp)
target_include_directories(bench_faults PRIVATE ${CMAKE_CURRENT_LIST_DIR}/../transport)
target_link_libraries(bench_faults spidar_emulation)
