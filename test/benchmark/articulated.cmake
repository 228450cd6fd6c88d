# Peers of bench_articulated: KDL, MuJoCo, Bullet (double precision), as Debian packages them.
find_package(orocos_kdl REQUIRED)
find_library(MUJOCO_LIBRARY NAMES mujoco REQUIRED)
set(articulated_bullet)
foreach(part BulletDynamics BulletCollision LinearMath)
  find_library(BULLET_${part} NAMES ${part}-float64 REQUIRED)
  list(APPEND articulated_bullet ${BULLET_${part}})
endforeach()
# Compiled as Debian compiled KDL: without -march, and with no symbol in common with the benchmark.
add_library(kdl_chain SHARED ${CMAKE_CURRENT_SOURCE_DIR}/kdl_chain.cpp)
set_target_properties(kdl_chain PROPERTIES CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
target_include_directories(kdl_chain SYSTEM PRIVATE ${orocos_kdl_INCLUDE_DIRS})
target_link_libraries(kdl_chain PRIVATE ${orocos_kdl_LIBRARIES} -Wl,-Bsymbolic)
target_sources(bench_articulated PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/articulated_peers.cpp)
set_source_files_properties(${CMAKE_CURRENT_SOURCE_DIR}/articulated_peers.cpp PROPERTIES
  COMPILE_DEFINITIONS BT_USE_DOUBLE_PRECISION)
target_include_directories(bench_articulated SYSTEM PRIVATE /usr/include/bullet)
target_link_libraries(bench_articulated kdl_chain ${MUJOCO_LIBRARY} ${articulated_bullet})
include(${CMAKE_CURRENT_SOURCE_DIR}/robots.cmake)
