"""Scenes from USD stages, by usd-core.

Each module imports only from modules above it in this list::

    transforms      transforms as translations, rotations and scales
    keyframes       keys that follow transforms over time
    readers         shaders that read primvars
    time_samples    which values change, and when
    files           which files may be read, and .usdz archives
    images          image files, and channels packed to textures
    context         the stage, its time and the scene that all modules share
    primvars        primvars of prims, and those per copy of an instancer
    traversal       the prims that are visible and meant for rendering
    animation       nodes and keyframes of the scene
    surfaces        the inputs of surface shaders
    materials       materials by shader
    geometry        triangles, vertices and subsets of meshes
    shapes          spheres, cubes, cylinders, cones, capsules and planes
    skeletons       joints and skins
    blend_shapes    morph targets and their weights
    instances       meshes that instances share, and where they are shown
    instancers      copies of prototypes
    meshes          rigid and deforming meshes
    lights          lights other than domes
    dome_lights     environments
    cameras         cameras and their exposures
    stage           from_usd() and usd_exposures()
"""
