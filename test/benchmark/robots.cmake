# The scene loader, which the core does not know, and the measurement of published robots.
if(NOT TARGET penalty_sim_scene)
  add_subdirectory(${CMAKE_CURRENT_SOURCE_DIR}/../../penalty_sim/scene ${CMAKE_CURRENT_BINARY_DIR}/scene)
endif()
find_package(orocos_kdl REQUIRED)
find_package(tinyxml2 REQUIRED)
target_sources(bench_${name} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/articulated_robots.cpp ${CMAKE_CURRENT_SOURCE_DIR}/robots_actors.cpp
  ${CMAKE_CURRENT_SOURCE_DIR}/robots_files.cpp ${CMAKE_CURRENT_SOURCE_DIR}/robots_kdl.cpp ${CMAKE_CURRENT_SOURCE_DIR}/robots_numbers.cpp
  ${CMAKE_CURRENT_SOURCE_DIR}/robots_sensors.cpp ${CMAKE_CURRENT_SOURCE_DIR}/robots_services.cpp)
target_include_directories(bench_${name} SYSTEM PRIVATE ${orocos_kdl_INCLUDE_DIRS})
target_link_libraries(bench_${name} penalty_sim_scene tinyxml2::tinyxml2 ${orocos_kdl_LIBRARIES})
