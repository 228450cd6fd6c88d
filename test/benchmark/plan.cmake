# The scene loader.
if(NOT TARGET penalty_sim_scene)
  add_subdirectory(${CMAKE_CURRENT_SOURCE_DIR}/../../penalty_sim/scene ${CMAKE_CURRENT_BINARY_DIR}/scene)
endif()
target_link_libraries(bench_plan penalty_sim_scene)

# World::hash() of every shipped scene, to compare two builds with.
add_executable(scene_hashes ${CMAKE_CURRENT_SOURCE_DIR}/scene_hashes.cpp)
target_link_libraries(scene_hashes penalty_sim_scene haptic_comparators)
target_compile_features(scene_hashes PRIVATE cxx_std_17)
target_compile_definitions(scene_hashes PRIVATE HAPTIC_SOURCE_DIR="${CMAKE_CURRENT_SOURCE_DIR}/../..")
