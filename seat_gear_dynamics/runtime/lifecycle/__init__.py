"""Managed nodes: the state machine of ROS 2, the services that drive it, and publishers that follow it."""
