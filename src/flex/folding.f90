!> What bending does to the axial coordinates where these follow at rest: the foreshortening h(eta_b) that makes the elastic
!> energy least, and its derivative. Quadratic and linear in the bending coordinates; plain kernels of the time loop.
!> Floor: flex. Source: doc/theory, eqs. (137), (138).
module limber_flex_folding
   use limber_base_kinds, only: wp
   use limber_flex_reduced, only: reduced_type
   implicit none
   private
   public :: start_folding, foreshortening, fold_matrix, fold_curvature

contains

   !> Makes the axial coordinates of a straight beam follow at rest: its constants are there, those of the foreshortening follow.
   pure subroutine start_folding(body)
      type(reduced_type), intent(inout) :: body
      integer :: j
      if (body%n == body%bending) return
      body%condensed = .true.
      allocate (body%fold(body%n - body%bending, size(body%cubic, 1)))
      do j = 1, size(body%fold, 1)
         body%fold(j, :) = -body%cubic(:, j)/body%omega2(body%bending + j)
      end do
   end subroutine start_folding

   !> h = fold z: the axial coordinates of least energy. Zero where bending does not stretch: in the models linear and k_g.
   pure subroutine foreshortening(body, eta, h)
      type(reduced_type), intent(in) :: body
      !> Bending coordinates (bending)
      real(wp), intent(in) :: eta(:)
      !> Axial coordinates (n - bending)
      real(wp), intent(inout) :: h(:)
      integer :: i, j, k, p
      h = 0.0_wp
      if (.not. body%full) return
      p = 0
      do j = 1, body%bending
         do i = 1, j
            p = p + 1
            do k = 1, size(h)
               h(k) = h(k) + body%fold(k, p)*eta(i)*eta(j)
            end do
         end do
      end do
   end subroutine foreshortening

   !> H = dh/d eta_b; in the model k_g that of the force by which axial loads act on the bending.
   pure subroutine fold_matrix(body, eta, matrix)
      type(reduced_type), intent(in) :: body
      !> Bending coordinates (bending)
      real(wp), intent(in) :: eta(:)
      !> Rows: axial coordinates, columns: bending ones (n - bending, bending)
      real(wp), intent(inout) :: matrix(:, :)
      integer :: i, j, k, p
      matrix = 0.0_wp
      if (.not. body%geometric) return
      p = 0
      do j = 1, body%bending
         do i = 1, j
            p = p + 1
            do k = 1, size(matrix, 1)
               matrix(k, i) = matrix(k, i) + body%fold(k, p)*eta(j)
               matrix(k, j) = matrix(k, j) + body%fold(k, p)*eta(i)
            end do
         end do
      end do
   end subroutine fold_matrix

   !> Adds the derivative of -H^T load with respect to the bending coordinates, the load held, to a matrix (bending, bending).
   pure subroutine fold_curvature(body, load, matrix)
      type(reduced_type), intent(in) :: body
      !> Forces on the axial coordinates (n - bending)
      real(wp), intent(in) :: load(:)
      real(wp), intent(inout) :: matrix(:, :)
      integer :: i, j, p
      if (.not. body%geometric) return
      p = 0
      do j = 1, body%bending
         do i = 1, j
            p = p + 1
            matrix(i, j) = matrix(i, j) - dot_product(body%fold(:, p), load)
            matrix(j, i) = matrix(j, i) - dot_product(body%fold(:, p), load)
         end do
      end do
   end subroutine fold_curvature

end module limber_flex_folding
