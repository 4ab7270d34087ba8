"""Parameters of a node: values and descriptors, declaring, setting atomically, and the services of `ros2 param`."""
