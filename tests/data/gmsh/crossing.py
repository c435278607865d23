"""Writes crossing_*.msh with Gmsh's own Python interface: two crossing faults and one buried fracture in a block of two
rocks, 6 x 3 x 6 hexahedra of unequal size. Run in this folder with the gmsh package (4.15 wrote the files here)."""
import gmsh

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
occ, mesh = gmsh.model.occ, gmsh.model.mesh
boxes = []
X, Z = [0, 1, 2, 4], [0, 1, 2, 4]
for i in range(3):
    for k in range(3):
        boxes.append((3, occ.addBox(X[i], 0, Z[k], X[i + 1] - X[i], 2, Z[k + 1] - Z[k])))
occ.fragment(boxes[:1], boxes[1:])
occ.synchronize()


def centre(entity):
    return occ.getCenterOfMass(*entity)


def near(a, b):
    return abs(a - b) < 1e-9


for curve in gmsh.model.getEntities(1):
    low_high = gmsh.model.getBoundingBox(*curve)
    along_y = low_high[4] - low_high[1] > 1.5
    mesh.setTransfiniteCurve(curve[1], 4 if along_y else 3)
for surface in gmsh.model.getEntities(2):
    mesh.setTransfiniteSurface(surface[1])
    mesh.setRecombine(*surface)
for volume in gmsh.model.getEntities(3):
    mesh.setTransfiniteVolume(volume[1])


def group(dimension, name, chosen):
    tags = [e[1] for e in gmsh.model.getEntities(dimension) if chosen(centre(e))]
    assert tags, name
    gmsh.model.addPhysicalGroup(dimension, tags, name=name)


group(3, "rock", lambda c: True)
group(3, "soft layer", lambda c: c[2] < 1)
group(2, "fault", lambda c: near(c[0], 1) and c[2] > 1)
group(2, "crossing upper", lambda c: near(c[2], 2) and c[0] < 2)
group(2, "bottom", lambda c: near(c[2], 0))
group(2, "top", lambda c: near(c[2], 4))
group(2, "east", lambda c: near(c[0], 4))
group(1, "an edge", lambda c: near(c[0], 0) and near(c[2], 0))
mesh.generate(3)
for version in (2.2, 4.1):
    for binary in (0, 1):
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.Binary", binary)
        kind = "binary" if binary else "ascii"
        gmsh.write(f"crossing_{str(version).replace('.', '')}_{kind}.msh")
