"""What GNSS receivers send (NMEA 0183, UBX) to fixes. Pure: bytes and arrival stamps come from outside."""
