# Included at the end of each project(): what a catkin package installs is a component of its name.
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME ${PROJECT_NAME})
