"""What cannot be bent is refused in one sentence, and nothing is changed."""

import bpy
import pytest
from heads import add_head, bend_keys, select, small_head


@pytest.fixture
def head():
    return add_head(small_head("jawOpen"))


def refused(match: str, operator=None, **options):
    """Run an operator that must report an error, which bpy raises."""
    with pytest.raises(RuntimeError, match=match):
        (operator or bpy.ops.elastomorph.bend)(**options)


def test_without_shape_keys_there_is_nothing_to_press():
    mesh = bpy.data.meshes.new("plain")
    thing = bpy.data.objects.new("plain", mesh)
    bpy.context.scene.collection.objects.link(thing)
    select(thing)
    assert not bpy.ops.elastomorph.bend.poll()


def test_a_basis_alone(head):
    head.shape_key_remove(head.data.shape_keys.key_blocks["jawOpen"])
    refused("Head has no shape keys beside its basis")


def test_a_mesh_that_two_objects_use(head):
    second = bpy.data.objects.new("Second", head.data)
    bpy.context.scene.collection.objects.link(second)
    refused("the mesh of Head is used by 2 objects")
    assert not bend_keys(head)


def test_a_fake_user_is_no_second_object(head):
    head.data.use_fake_user = True
    assert bpy.ops.elastomorph.bend() == {"FINISHED"}


def test_absolute_keys(head):
    head.data.shape_keys.use_relative = False
    refused("the shape keys of Head are absolute")


def test_edit_mode(head):
    bpy.ops.object.mode_set(mode="EDIT")
    refused("in object mode")
    bpy.ops.object.mode_set(mode="OBJECT")


def test_an_object_without_thickness(head):
    head.scale = (1, 0, 1)
    bpy.context.view_layer.update()
    refused("Head is scaled to 0 along an axis")


def test_keys_that_move_nothing(head):
    block = head.data.shape_keys.key_blocks["jawOpen"]
    block.data.foreach_set("co", [x for v in head.data.vertices for x in v.co])
    refused("No shape key of Head moves anything")


def test_a_method_that_does_not_exist(head):
    refused("rotate", method="rotate")
    assert not bend_keys(head)


def test_the_basis_is_no_path(head):
    head.active_shape_key_index = 0
    refused("is its basis", keys="ACTIVE")
    refused("is its basis", bpy.ops.elastomorph.preview)


def test_a_linked_mesh(head, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, wanted):
        wanted.objects = ["Head"]
    thing = bpy.data.objects["Head"]
    bpy.context.scene.collection.objects.link(thing)
    select(thing)
    refused("Head is linked from .*library.blend")
    local = thing.override_create()
    bpy.context.scene.collection.objects.link(local)
    select(local)
    refused("is linked from .*library.blend")


def test_a_record_that_cannot_be_read(head):
    bpy.ops.elastomorph.bend()
    head.data.shape_keys["elastomorph"] = '{"bends": [{"name": 1}]}'
    refused("the record of bends of Head cannot be read")


def test_nothing_to_bake(head):
    refused("Head has no bends to bake", bpy.ops.elastomorph.bake)


def test_one_key_of_a_file_with_folds(head):
    """What a folded target adds to its own weight has no place in Blender."""
    curve = {"breaks": [0.0, 1.0], "coefficients": [[0.0, -0.5, 0.5]]}
    folded = {"name": "jawOpen", "target": "jawOpen", "method": "ease", "fold": curve}
    head.data["elastomorph"] = {"version": 2, "morphs": [{**folded, "bends": []}]}
    head.active_shape_key_index = 1
    refused("Head came from a file with folds", keys="ACTIVE")
    assert bpy.ops.elastomorph.bend() == {"FINISHED"}
    assert "elastomorph" not in head.data


def test_extras_that_cannot_be_read(head):
    head.data["elastomorph"] = {"version": 1, "morphs": [{"bends": [{"target": "x"}]}]}
    refused("of the mesh Head, which says what its bends are, cannot be read")
