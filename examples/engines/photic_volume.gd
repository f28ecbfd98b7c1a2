# SPDX-License-Identifier: Apache-2.0
# Godot 4: reads NAME.ktx2 of `photic export` (and NAME_rgb.ktx2 of a coloured volume) into the uniforms of
# photic_light.gdshader.
#     var light := PhoticVolume.new()
#     if light.read("res://pool.ktx2"): light.give_to($Floor.material_override)
class_name PhoticVolume
extends RefCounted

var texture: ImageTexture3D
var rgb: ImageTexture3D
var texture_from_world := Projection.IDENTITY
var size := Vector3.ONE
var reference_irradiance := 1.0

## False, and a message, when the file is none that `photic export` wrote.
func read(path: String) -> bool:
	var bytes := FileAccess.get_file_as_bytes(path)
	if bytes.size() < 104 or bytes.slice(1, 7).get_string_from_ascii() != "KTX 20" or bytes.decode_u32(12) != 97:
		push_error("%s is no .ktx2 of photic export" % path)
		return false
	var metadata: Dictionary = _metadata(bytes)
	texture = _texture(bytes)
	size = Vector3(bytes.decode_u32(20), bytes.decode_u32(24), bytes.decode_u32(28))
	reference_irradiance = metadata["reference_irradiance"]
	var rows: Array = metadata["world_from_texture"]
	# Godot has y up: its (x, y, z) are (x, z, -y) of Photic's.
	var world_from_texture := Projection(
		Vector4(rows[0][0], rows[2][0], -rows[1][0], 0.0), Vector4(rows[0][1], rows[2][1], -rows[1][1], 0.0),
		Vector4(rows[0][2], rows[2][2], -rows[1][2], 0.0), Vector4(rows[0][3], rows[2][3], -rows[1][3], 1.0))
	texture_from_world = world_from_texture.inverse()
	rgb = null
	var second = metadata.get("rgb_texture")
	if second != null:
		rgb = _texture(FileAccess.get_file_as_bytes(path.get_base_dir().path_join(second)))
	return true

func give_to(material: ShaderMaterial) -> void:
	material.set_shader_parameter("photic_light", texture)
	material.set_shader_parameter("photic_rgb", rgb if rgb != null else texture)
	material.set_shader_parameter("photic_coloured", rgb != null)
	material.set_shader_parameter("photic_size", size)
	material.set_shader_parameter("photic_texture_from_world", texture_from_world)

# The key `photic` among the key/values (docs/files.md).
func _metadata(bytes: PackedByteArray) -> Dictionary:
	var at := bytes.decode_u32(56)
	var end := at + bytes.decode_u32(60)
	while at < end:
		var length := bytes.decode_u32(at)
		var pair := bytes.slice(at + 4, at + 4 + length)
		var zero := pair.find(0)
		if pair.slice(0, zero).get_string_from_utf8() == "photic":
			return JSON.parse_string(pair.slice(zero + 1).get_string_from_utf8())
		at += 4 + ((length + 3) & ~3)
	return {}

func _texture(bytes: PackedByteArray) -> ImageTexture3D:
	var width := bytes.decode_u32(20)
	var height := bytes.decode_u32(24)
	var depth := bytes.decode_u32(28)
	var first := bytes.decode_u64(80)
	var slice_bytes := width * height * 8
	var slices: Array[Image] = []
	for z in depth:
		var from := first + z * slice_bytes
		slices.append(Image.create_from_data(width, height, false, Image.FORMAT_RGBAH, bytes.slice(from, from + slice_bytes)))
	var made := ImageTexture3D.new()
	made.create(Image.FORMAT_RGBAH, width, height, depth, false, slices)
	return made
