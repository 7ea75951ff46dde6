!> Element kernels against what they are defined by: rigid-body motions, patch test, quadrature, finite differences.
program test_beam
   use limber_base_kinds, only: wp
   use limber_base_lapack, only: dsyev
   use limber_beam_element_matrices, only: axial_dofs, axial_stiffness, beam_stiffness, bending_curvature, bending_dofs, &
      & bending_shape, &
      & bending_slope, bending_stiffness, geometric_stiffness, lumped_mass
   use scenes, only: derivative, gauss_point, gauss_weight, random
   use testing, only: check, check_close, finish
   implicit none
   !> Lengths far from one show a wrong power of l
   real(wp), parameter :: lengths(4) = [0.037_wp, 0.5_wp, 1.0_wp, 8.3_wp]
   real(wp), parameter :: ea = 3.1e4_wp, ei = 7.3_wp
   !> A few roundings of sums of a dozen products
   real(wp), parameter :: round_off = 2.0e-14_wp
   integer :: i

   do i = 1, size(lengths)
      call test_stiffness(lengths(i))
      call test_quadrature(lengths(i))
      call test_geometric_stiffness(lengths(i))
      call test_shapes(lengths(i))
   end do
   call test_patch()
   call finish()

contains

   !> k_E: symmetric, no force in the three rigid-body motions, rank three.
   subroutine test_stiffness(l)
      real(wp), intent(in) :: l
      real(wp) :: k(6, 6), scale(6), rigid(6, 3), value(6), work(60)
      integer :: info, j
      k = beam_stiffness(ea, ei, l)
      call check(maxval(abs(k - transpose(k))) <= 0.0_wp, 'k_E is symmetric')
      call check(maxval(abs(k(axial_dofs, bending_dofs))) <= 0.0_wp, 'axial and bending do not couple')
      call check(maxval(abs(k(axial_dofs, axial_dofs) - axial_stiffness(ea, l))) <= 0.0_wp, 'k_E holds the axial part')
      call check(maxval(abs(k(bending_dofs, bending_dofs) - bending_stiffness(ei, l))) <= 0.0_wp, 'k_E holds the bending part')
      rigid(:, 1) = [1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp]
      rigid(:, 2) = [0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp]
      rigid(:, 3) = [0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, l, 1.0_wp]
      do j = 1, 3
         call check(all(abs(matmul(k, rigid(:, j))) <= round_off*matmul(abs(k), abs(rigid(:, j)))), &
            & 'a rigid-body motion makes no force')
      end do
      ! In units of EA/l, EI/l^3 and l all eigenvalues that are not zero are of order one
      scale = [sqrt(l/ea), sqrt(l**3/ei), sqrt(l/ei), sqrt(l/ea), sqrt(l**3/ei), sqrt(l/ei)]
      do j = 1, 6
         k(:, j) = k(:, j)*scale*scale(j)
      end do
      call dsyev('N', 'L', 6, k, 6, value, work, size(work), info)
      call check(info == 0 .and. all(abs(value(:3)) <= 1.0e-13_wp) .and. all(value(4:) > 0.5_wp), 'the rank of k_E is three')
      call check_close(2*lumped_mass(2.7_wp, l), 2.7_wp*l, 0.0_wp, 'both nodes carry the mass of the element')
   end subroutine test_stiffness

   !> Bending and geometric stiffness are the integrals of w''^2 and w'^2 of their shape functions.
   subroutine test_quadrature(l)
      real(wp), intent(in) :: l
      real(wp) :: bending(4, 4), tension(4, 4), shape(4), x
      integer :: g, j
      bending = 0.0_wp
      tension = 0.0_wp
      do g = 1, 5
         x = 0.5_wp*l*(1 + gauss_point(g))
         shape = bending_curvature(x, l)
         do j = 1, 4
            bending(:, j) = bending(:, j) + 0.5_wp*l*gauss_weight(g)*ei*shape*shape(j)
         end do
         shape = bending_slope(x, l)
         do j = 1, 4
            tension(:, j) = tension(:, j) + 0.5_wp*l*gauss_weight(g)*shape*shape(j)
         end do
      end do
      call check(all(abs(bending - bending_stiffness(ei, l)) <= round_off*abs(bending)), 'bending stiffness by quadrature')
      call check(all(abs(tension - geometric_stiffness(l)) <= round_off*(abs(tension) + maxval(abs(tension))*1.0e-2_wp)), &
         & 'geometric stiffness by quadrature')
   end subroutine test_quadrature

   !> k_G: symmetric, the exact integral of w'^2 of a cubic, nothing for a translation, l for a unit rotation.
   subroutine test_geometric_stiffness(l)
      real(wp), intent(in) :: l
      real(wp) :: k(4, 4), c(0:3), d(4), exact
      integer :: j
      k = geometric_stiffness(l)
      call check(maxval(abs(k - transpose(k))) <= 0.0_wp, 'k_G is symmetric')
      call check(maxval(abs(matmul(k, [1.0_wp, 0.0_wp, 1.0_wp, 0.0_wp]))) <= round_off*maxval(abs(k)), &
         & 'a translation feels no tension')
      d = [0.0_wp, 1.0_wp, l, 1.0_wp]
      call check_close(dot_product(d, matmul(k, d)), l, round_off*10*l, 'a unit rotation: the integral is the length')
      do j = 1, 5
         ! w = c0 + c1 x + c2 x^2 + c3 x^3 with terms of equal size
         c = [random(), random()/l, random()/l**2, random()/l**3]
         d = [c(0), c(1), c(0) + c(1)*l + c(2)*l**2 + c(3)*l**3, c(1) + 2*c(2)*l + 3*c(3)*l**2]
         exact = c(1)**2*l + 2*c(1)*c(2)*l**2 + (4*c(2)**2 + 6*c(1)*c(3))*l**3/3 + 3*c(2)*c(3)*l**4 + 9*c(3)**2*l**5/5
         call check_close(dot_product(d, matmul(k, d)), exact, 20*round_off*sum(abs(c(1:)*[l, l**2, l**3]))**2/l, &
            & 'k_G of a cubic')
      end do
   end subroutine test_geometric_stiffness

   !> Values at the ends, a cubic reproduced, and derivatives by a stencil that is exact for cubics.
   subroutine test_shapes(l)
      real(wp), intent(in) :: l
      real(wp) :: x, h, ends(4, 4), unit(4, 4), size_of(4)
      integer :: j
      ends(1, :) = bending_shape(0.0_wp, l)
      ends(2, :) = bending_slope(0.0_wp, l)
      ends(3, :) = bending_shape(l, l)
      ends(4, :) = bending_slope(l, l)
      unit = 0.0_wp
      do j = 1, 4
         unit(j, j) = 1.0_wp
      end do
      call check(maxval(abs(ends - unit)) <= round_off, 'shape functions at the ends')
      h = 0.05_wp*l
      size_of = [1.0_wp, l, 1.0_wp, l]
      do j = 1, 9
         x = 0.1_wp*j*l
         call check(all(abs(derivative(bending_shape(x - 2*h, l), bending_shape(x - h, l), bending_shape(x + h, l), &
            & bending_shape(x + 2*h, l), h) - bending_slope(x, l)) <= 1.0e-13_wp*size_of/l), 'slope by differences')
         call check(all(abs(derivative(bending_slope(x - 2*h, l), bending_slope(x - h, l), bending_slope(x + h, l), &
            & bending_slope(x + 2*h, l), h) - bending_curvature(x, l)) <= 2.0e-12_wp*size_of/l**2), 'curvature by differences')
         call check_close(dot_product(bending_shape(x, l), [0.0_wp, 0.0_wp, l**3, 3*l**2]), x**3, 10*round_off*l**3, &
            & 'the shape functions hold the cubic')
      end do
   end subroutine test_shapes

   !> Three unequal elements in a row: fields of constant strain, curvature and shear leave every node between them without
   !> force and have the exact forces at the ends and the exact energy.
   subroutine test_patch()
      real(wp), parameter :: x(4) = [0.0_wp, 0.7_wp, 1.1_wp, 2.4_wp]
      real(wp), parameter :: strain = 1.3e-3_wp, curvature = 0.4_wp, change = 0.3_wp
      real(wp) :: k(12, 12), d(12), f(12), expected(12), scale
      integer :: e, at
      k = 0.0_wp
      do e = 1, 3
         at = 3*(e - 1)
         k(at + 1:at + 6, at + 1:at + 6) = k(at + 1:at + 6, at + 1:at + 6) + beam_stiffness(ea, ei, x(e + 1) - x(e))
      end do

      d = 0.0_wp
      d(1::3) = strain*x
      expected = 0.0_wp
      expected([1, 10]) = [-ea*strain, ea*strain]
      f = matmul(k, d)
      call check(maxval(abs(f - expected)) <= 1.0e-13_wp*ea*strain, 'patch test: constant strain')
      call check_close(0.5_wp*dot_product(d, f), 0.5_wp*ea*strain**2*x(4), 1.0e-13_wp*ea*strain**2, 'energy of constant strain')

      d = 0.0_wp
      d(2::3) = 0.5_wp*curvature*x**2
      d(3::3) = curvature*x
      expected = 0.0_wp
      expected([3, 12]) = [-ei*curvature, ei*curvature]
      f = matmul(k, d)
      ! Forces cancel from 12 EI w / l^3 of the shortest element
      scale = 12*ei*maxval(abs(d))/0.4_wp**3
      call check(maxval(abs(f - expected)) <= 1.0e-14_wp*scale, 'patch test: constant curvature')
      call check_close(0.5_wp*dot_product(d, f), 0.5_wp*ei*curvature**2*x(4), 1.0e-14_wp*scale, 'energy of constant curvature')

      d = 0.0_wp
      d(2::3) = change*x**3/6
      d(3::3) = change*x**2/2
      expected = 0.0_wp
      expected([2, 11, 12]) = [ei*change, -ei*change, ei*change*x(4)]
      f = matmul(k, d)
      scale = 12*ei*maxval(abs(d))/0.4_wp**3
      call check(maxval(abs(f - expected)) <= 1.0e-14_wp*scale, 'patch test: constant shear')
   end subroutine test_patch

end program test_beam
