"""Pictures of faces with labels: colour, depth, normals, parts, landmarks, cameras."""
