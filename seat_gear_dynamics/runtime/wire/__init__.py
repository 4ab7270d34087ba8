"""DDS itself: domain, participant, readers and writers, their QoS and types, waiting on them."""
