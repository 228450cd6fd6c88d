# Parts of this benchmark, and the scene loader.
if(NOT TARGET penalty_sim_scene)
  add_subdirectory(${CMAKE_CURRENT_SOURCE_DIR}/../../penalty_sim/scene ${CMAKE_CURRENT_BINARY_DIR}/scene)
endif()
target_sources(bench_right PRIVATE ${CMAKE_CURRENT_LIST_DIR}/right_carriers.cpp ${CMAKE_CURRENT_LIST_DIR}/right_balances.cpp
  ${CMAKE_CURRENT_LIST_DIR}/right_belts.cpp ${CMAKE_CURRENT_LIST_DIR}/right_drops.cpp
  ${CMAKE_CURRENT_LIST_DIR}/right_energy.cpp ${CMAKE_CURRENT_LIST_DIR}/right_ground.cpp
  ${CMAKE_CURRENT_LIST_DIR}/right_impacts.cpp
  ${CMAKE_CURRENT_LIST_DIR}/right_order.cpp ${CMAKE_CURRENT_LIST_DIR}/right_power.cpp ${CMAKE_CURRENT_LIST_DIR}/right_rings.cpp
  ${CMAKE_CURRENT_LIST_DIR}/right_rolling.cpp)
target_link_libraries(bench_right penalty_sim_scene)
