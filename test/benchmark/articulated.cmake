# Peers of bench_articulated: KDL, MuJoCo, Bullet (double precision), as Debian packages them.
find_package(orocos_kdl REQUIRED)
find_library(MUJOCO_LIBRARY NAMES mujoco REQUIRED)
set(articulated_bullet)
foreach(part BulletDynamics BulletCollision LinearMath)
  find_library(BULLET_${part} NAMES ${part}-float64 REQUIRED)
  list(APPEND articulated_bullet ${BULLET_${part}})
endforeach()
target_sources(bench_articulated PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/articulated_peers.cpp)
set_source_files_properties(${CMAKE_CURRENT_SOURCE_DIR}/articulated_peers.cpp PROPERTIES
  COMPILE_DEFINITIONS BT_USE_DOUBLE_PRECISION)
target_include_directories(bench_articulated SYSTEM PRIVATE /usr/include/bullet ${orocos_kdl_INCLUDE_DIRS})
target_link_libraries(bench_articulated ${orocos_kdl_LIBRARIES} ${MUJOCO_LIBRARY} ${articulated_bullet})
include(${CMAKE_CURRENT_SOURCE_DIR}/robots.cmake)
