# SPDX-License-Identifier: Apache-2.0
# A floor and a ball in the light of pool.ktx2; docs/recipes.md says what belongs beside this file.
extends Node3D

func _ready() -> void:
	var light := PhoticVolume.new()
	if not light.read("res://pool.ktx2"):
		get_tree().quit(1)
		return
	var shader := load("res://photic_light.gdshader")
	var plane := PlaneMesh.new()
	plane.size = Vector2(2, 2)
	var ball := SphereMesh.new()
	ball.radius = 0.22
	ball.height = 0.44
	for part in [[plane, Vector3(0, -1.5, 0), Color(0.62, 0.66, 0.66)], [ball, Vector3(0.25, -1.1, 0.2), Color(0.8, 0.5, 0.4)]]:
		var material := ShaderMaterial.new()
		material.shader = shader
		light.give_to(material)
		material.set_shader_parameter("albedo", part[2])
		var body := MeshInstance3D.new()
		body.mesh = part[0]
		body.position = part[1]
		body.material_override = material
		add_child(body)
	var camera := Camera3D.new()
	camera.fov = 40
	add_child(camera)
	camera.look_at_from_position(Vector3(-1.7, 0.1, 2.0), Vector3(0, -1.35, 0))
	var environment := Environment.new()
	environment.background_mode = Environment.BG_COLOR
	environment.background_color = Color(0.02, 0.05, 0.07)
	environment.ambient_light_source = Environment.AMBIENT_SOURCE_DISABLED
	environment.tonemap_mode = Environment.TONE_MAPPER_FILMIC
	environment.tonemap_white = 6.0
	camera.environment = environment
	if "--picture" in OS.get_cmdline_user_args():
		for i in 4:
			await RenderingServer.frame_post_draw
		get_viewport().get_texture().get_image().save_png("res://godot.png")
		get_tree().quit()
