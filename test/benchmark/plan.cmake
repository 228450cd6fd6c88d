# The scene loader, and the world twice from its sources: whole, and without what a plain scene does not need. Both are
# linked in the same way, so that calls between files cost the same.
if(NOT TARGET penalty_sim_scene)
  add_subdirectory(${CMAKE_CURRENT_SOURCE_DIR}/../../penalty_sim/scene ${CMAKE_CURRENT_BINARY_DIR}/scene)
endif()
target_link_libraries(bench_plan penalty_sim_scene)
file(GLOB world_sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/../../src/haptic_core/world/*.cpp)
foreach(kind whole plain)
  add_executable(world_cost_${kind} ${CMAKE_CURRENT_SOURCE_DIR}/world_cost.cpp ${world_sources})
  target_link_libraries(world_cost_${kind} haptic_core::haptic_core)
  target_compile_options(world_cost_${kind} PRIVATE -fno-math-errno -fno-trapping-math)
  string(TOUPPER ${kind} upper)
  target_compile_definitions(bench_plan PRIVATE HAPTIC_COST_OF_${upper}="$<TARGET_FILE:world_cost_${kind}>")
  add_dependencies(bench_plan world_cost_${kind})
endforeach()
target_compile_definitions(world_cost_plain PRIVATE HAPTIC_PLAIN_WORLD)

# World::hash() of every shipped scene, to compare two builds with.
add_executable(scene_hashes ${CMAKE_CURRENT_SOURCE_DIR}/scene_hashes.cpp)
target_link_libraries(scene_hashes penalty_sim_scene)
target_compile_features(scene_hashes PRIVATE cxx_std_17)
target_compile_definitions(scene_hashes PRIVATE HAPTIC_SOURCE_DIR="${CMAKE_CURRENT_SOURCE_DIR}/../..")
