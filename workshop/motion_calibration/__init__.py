"""Where an inertial unit sits to a lidar, from a drive that both recorded."""
