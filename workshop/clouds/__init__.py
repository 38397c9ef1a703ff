"""Point clouds from files and bags: PCD, PLY, KITTI's files; PointCloud2 and packets in ROS bags and MCAP."""
