# Parts of this benchmark, and the scene loader.
if(NOT TARGET penalty_sim_scene)
  add_subdirectory(${CMAKE_CURRENT_LIST_DIR}/../../penalty_sim/scene ${CMAKE_CURRENT_BINARY_DIR}/scene)
endif()
target_sources(bench_step PRIVATE ${CMAKE_CURRENT_LIST_DIR}/step_motion.cpp ${CMAKE_CURRENT_LIST_DIR}/step_bits.cpp
  ${CMAKE_CURRENT_LIST_DIR}/step_cases.cpp
  ${CMAKE_CURRENT_LIST_DIR}/step_plough.cpp
  ${CMAKE_CURRENT_LIST_DIR}/step_shaken.cpp
  ${CMAKE_CURRENT_LIST_DIR}/step_accuracy.cpp)
target_link_libraries(bench_step penalty_sim_scene)
