"""The signature with which a vehicle uploads a run segment over HTTP."""

# Request header: base64 of the Ed25519 signature over `signed_segment(...)`.
SIGNATURE_HEADER = "Vehicle-Signature"


def segment_path(sha256: str) -> str:
    """Where the segment of this content is PUT; a repeat is harmless."""
    return f"/api/v1/runs/segments/{sha256}"


def signed_segment(vehicle_id: str, sha256: str) -> bytes:
    """The bytes that the vehicle's key signs. Bound to the content, so that a copied request adds nothing."""
    return f"campusloop-segment\n{vehicle_id}\n{sha256}".encode()
