// SPDX-License-Identifier: Apache-2.0
// Unity: what a face gets of a baked volume, in units of the reference irradiance: multiply by the sun's colour and
// intensity, and by the albedo. PhoticVolume.cs fills the properties.
Texture3D<float4> _PhoticLight;  // flux x, y, z along Unity's axes, irradiance
SamplerState sampler_linear_clamp;
float4x4 _PhoticTextureFromWorld;
float4 _PhoticSize;  // texels

float PhoticIrradiance(float3 world, float3 normal)
{
    float3 place = mul(_PhoticTextureFromWorld, float4(world, 1.0)).xyz;
    float3 fade = saturate(min(place, 1.0 - place) * _PhoticSize.xyz + 0.5);
    float4 light = _PhoticLight.SampleLevel(sampler_linear_clamp, place, 0) * (fade.x * fade.y * fade.z);
    return max(0.0, -dot(normal, light.xyz));
}

// The same of the three textures of `photic export --l1`: less exact, as VRChat's and Bakery's light volumes have it.
Texture3D<float4> _PhoticL1_0, _PhoticL1_1, _PhoticL1_2;

float3 PhoticIrradianceL1(float3 world, float3 normal)
{
    float3 place = mul(_PhoticTextureFromWorld, float4(world, 1.0)).xyz;
    float4 a = _PhoticL1_0.SampleLevel(sampler_linear_clamp, place, 0);
    float4 b = _PhoticL1_1.SampleLevel(sampler_linear_clamp, place, 0);
    float4 c = _PhoticL1_2.SampleLevel(sampler_linear_clamp, place, 0);
    float3 red = float3(b.r, c.r, a.a), green = float3(b.g, c.g, b.a), blue = float3(b.b, c.b, c.a);
    return max(0.0, a.rgb + float3(dot(red, normal), dot(green, normal), dot(blue, normal)));
}
